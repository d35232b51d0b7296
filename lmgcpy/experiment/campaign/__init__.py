"""Campaigns: many cases of a study, or of a function of a user's own, with parameters varied, on many workers."""
