"""Identification of quantities of a case from measurements: priors, likelihoods, ways to the
posterior, what the data determine.
"""
