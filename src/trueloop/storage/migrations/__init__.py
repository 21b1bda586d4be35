"""How the store's tables came to be what they are: one script a schema, none of them ever changed."""
