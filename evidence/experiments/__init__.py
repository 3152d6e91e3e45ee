"""Tests in laboratories: what the statics predict for them, and what was measured."""
