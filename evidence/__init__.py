"""Scripts that measure the project: its figures, its shape, its speed."""
