from valvetrain.spring_card.card import CatalogueCard as CatalogueCard
from valvetrain.spring_card.card import SpringLoad as SpringLoad
from valvetrain.spring_card.fit import SpringFit as SpringFit
from valvetrain.spring_card.fit import spring_from_card as spring_from_card
from valvetrain.spring_card.tester import TesterFit as TesterFit
from valvetrain.spring_card.tester import card_from_table as card_from_table
from valvetrain.spring_card.tester import spring_from_tester as spring_from_tester
