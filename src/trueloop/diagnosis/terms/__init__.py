"""Which error of which axis the machine's model gets wrong, from what it left on many parts [4773 §3.3, Table 1]."""
