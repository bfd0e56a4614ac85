"""
Which spring stands behind a catalogue card?
============================================

A card tells two loads at two heights, the wire and the outer diameter. The spring that meets them
has turns and a free length; what the
card leaves open is said.
"""

import valvetrain as vt

card = vt.spring_card.CatalogueCard(
    wire_diameter="4.4 mm",
    outer_diameter="32 mm",
    installed_load=vt.spring_card.SpringLoad("46 mm", "350 N"),
    open_load=vt.spring_card.SpringLoad("34 mm", "830 N"),
    solid_height="29 mm",
)
found = vt.spring_card.spring_from_card(card)

print(
    f"{found.definition.total_coils:.2f} turns, free length {1e3 * found.definition.free_length:.1f} mm"
)
print(f"{found.verdict}; left open: {', '.join(found.free)}")

# %%
# The curve of that spring goes through both loads.

curve = vt.static_curve(found.definition, "24 mm", models="multi-mass")
figure = curve.plot()
