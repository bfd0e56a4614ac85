"""Films of a valve spring: frames, the space-time picture along a line, tracked highlights, surge."""
