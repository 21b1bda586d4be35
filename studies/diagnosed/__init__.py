"""A shop that cuts turned parts while something is wrong, written down beforehand: what diagnoses are judged by."""
