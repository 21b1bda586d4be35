"""The factory over HTTP: accounts and keys, addresses and who may use them, pages. It decides nothing about parts."""
