"""Parts of a user's own package: a spring model, a contact law, a lift law. Each is one file with
its SPEC and one entry point.
"""
