"""The same jobs in other programs, one file each, run in their own interpreter; none of them is
needed by the package.
"""
