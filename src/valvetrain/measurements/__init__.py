"""Measured things as files hold them: read by content, questions answered, noise kept."""
