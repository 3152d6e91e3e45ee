"""An independent check of every answer: it shares no code with what it checks."""
