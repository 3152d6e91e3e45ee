"""Static and dynamic verdicts side by side, and why they differ.

<<<<<<< HEAD
This room imports the root, `judge`, `parallel`, and of `blockstat` the root, `contact`, `analysis` and `sequence`.
=======
This room imports the root, `engine`, `judge`, `parallel`, and of `blockstat` the root, `contact` and `analysis`.
>>>>>>> main
"""
