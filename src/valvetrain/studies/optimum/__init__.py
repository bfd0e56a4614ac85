"""Optimisation: searches of springs and lift laws within bounds on any named quantities."""
