"""`trueloop surface …`"""
