"""Series known by one number a part, a characteristic or an offset: what to correct next, and with which weight."""
