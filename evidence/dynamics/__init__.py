"""What Bullet says where the answer is known: closed forms, loads, glue, stiffness, and the experiment of the paper.

A module takes its scenes from `evidence.scenes` and `evidence.references` and prints or writes a table."""
