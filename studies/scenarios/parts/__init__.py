"""What several scenarios have in common: records of parameters, and the problems that they make; no registry."""
