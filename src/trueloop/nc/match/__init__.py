"""The path of a program beside a profile or beside another path."""
