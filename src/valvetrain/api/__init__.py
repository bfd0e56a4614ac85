"""Cases, springs and trains as Python users hold them: objects with the keys of a case file, and
verbs that run them.
"""
