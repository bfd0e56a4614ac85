"""Forms in which test rigs record; each recognises its own content, whatever the file is called."""
