"""Which features of a sample's shape bias its modulus on a cuboid, by experiments on meshes."""
