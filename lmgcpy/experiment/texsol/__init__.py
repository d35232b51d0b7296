"""The TexSol studies in 2D and 3D: samples, studies, conclusions, reports, pictures."""
