"""QIF, the Quality Information Framework (ISO 23952): results of versions 2 and 3 read, of version 3.0 written."""
