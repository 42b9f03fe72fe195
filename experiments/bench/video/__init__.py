"""Videos, GIFs and strips of pictures, made from recordings."""
