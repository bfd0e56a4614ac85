"""A scanned spring: points read in bounded memory, the wire followed from tip to tip, its curves with their scatter."""
