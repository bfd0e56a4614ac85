"""Identification of quantities of a case from measurements: priors, likelihoods, three ways to the posterior, and what the data determine."""
