"""Writers of whole pages and of pictures, and the filler of the pages that are written by hand."""
