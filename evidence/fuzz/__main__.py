"""`python -m evidence.fuzz`."""

from evidence.fuzz.run import main

main()
