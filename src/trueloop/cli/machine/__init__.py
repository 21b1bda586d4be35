"""`trueloop machine …`"""
