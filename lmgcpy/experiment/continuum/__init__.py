"""The continuous model beside the runs of a TexSol study: fitted to the sand, and predicting the tests with a wire."""
