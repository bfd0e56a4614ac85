"""Feeds damaged and hostile input to the package and tells what ends in anything but an answer or
one sentence: ``make fuzz``.
"""
