from valvetrain.contact.law import ContactLaw as ContactLaw
from valvetrain.contact.library import build_contact_law as build_contact_law
