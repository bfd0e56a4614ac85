"""The spring and its train in motion: what is drawn, when, in which colours; for the page, for
pictures and for films.
"""
