"""Studies: what the product does on virtual machines and on published metal; `make studies` lists them."""
