"""Forms in which lifts are passed on; each recognises its own content, whatever the file is called."""
