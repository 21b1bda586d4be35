"""`trueloop link …`"""
