"""Point clouds: reading, levelling, filtering. The only part that knows file formats and Open3D."""
