"""From an image to the sample's shape: segmentation, sample frame, cuboid."""
