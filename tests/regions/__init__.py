"""Small meshes, and scenes made of them."""
