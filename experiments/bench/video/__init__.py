"""Videos, GIFs, moving pictures and strips of pictures, made from recordings."""
