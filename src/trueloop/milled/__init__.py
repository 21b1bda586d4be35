"""Milled parts: bores, bosses, slots, ribs and faces, the tools and work offsets that cut them, and their errors."""
