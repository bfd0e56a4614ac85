"""The validation book: numbers of the package beside closed forms, publications and other programs."""
