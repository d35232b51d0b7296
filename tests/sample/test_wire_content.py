"""The wire in an engineer's words. Numbers are those of a usual TexSol: polyester of 167 dtex, 0.15 % by weight."""

import numpy as np
import pytest

from lmgcpy.sample import axial_rigidity, bead_count, bead_mass, wire_3d, wire_content, wire_length


def test_bead_mass():
    """1 dtex is 0.1 g per km: 167 dtex are 16.7 g per km, or 16.7 mg per m, and 41.75 micrograms per 2.5 mm."""
    assert bead_mass(linear_density_dtex=1.0, spacing=1e4) == pytest.approx(1e-3)
    assert bead_mass(linear_density_dtex=167.0, spacing=0.0025) == pytest.approx(41.75e-9)


def test_length_by_content():
    """150 km/m³ in two litres are 300 m."""
    assert wire_length(content_km_per_m3=150.0, volume=0.002) == pytest.approx(300.0)
    assert wire_content(length=300.0, volume=0.002) == pytest.approx(150.0)


def test_length_by_weight():
    """Of sand of 1600 kg/m³, 0.15 % are 2.4 kg/m³ of wire, at 16.7 mg/m 144 km/m³: within the usual 100 to 200."""
    length = wire_length(content_by_weight=0.0015, sand_mass=1600.0 * 0.002, linear_density_dtex=167.0)
    assert length == pytest.approx(0.0048 / 16.7e-6)
    assert 100.0 < wire_content(length=length, volume=0.002) < 200.0
    assert wire_content(length=length, volume=0.002) == pytest.approx(143.7, abs=0.05)


def test_axial_rigidity():
    """Polyester of 1380 kg/m³: a section of 0.0121 mm², times 10 GPa."""
    assert axial_rigidity(linear_density_dtex=167.0, young_modulus=1e10, density=1380.0) == pytest.approx(121.0, abs=0.05)


def test_bead_count():
    assert bead_count(length=12.5, spacing=0.0025) == 5001
    assert bead_count(length=0.0, spacing=0.0025) == 1


def test_a_sample_of_the_usual_content():
    """From 150 km/m³ to the wire in the box, whose beads weigh what it weighs, but for the half links at its ends."""
    box, radius, interstice = (0.05, 0.05, 0.05), 0.0003, 0.0019
    volume, spacing = np.prod(box), interstice + 2.0 * radius
    length = wire_length(content_km_per_m3=150.0, volume=volume)
    thread = wire_3d(
        box=box, bead_radius=radius, interstice=interstice, bead_count=bead_count(length=length, spacing=spacing)
    )
    assert not thread.cut
    assert wire_content(length=thread.length, volume=volume) == pytest.approx(150.0, rel=1e-3)
    mass = thread.bead_count * bead_mass(linear_density_dtex=167.0, spacing=thread.spacing)
    assert mass == pytest.approx(length * 16.7e-6, rel=1e-3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: wire_length(), "got none of them"),
        (lambda: wire_length(content_km_per_m3=150.0), "content_km_per_m3 and volume, or content_by_weight, sand_mass"),
        (lambda: wire_length(content_km_per_m3=150.0, volume=1.0, sand_mass=1.0), "got content_km_per_m3, volume, sand"),
        (
            lambda: wire_length(content_by_weight=0.15, sand_mass=1.0, linear_density_dtex=0.0),
            "linear_density_dtex must be above 0 dtex, got 0 dtex",
        ),
        (
            lambda: wire_length(content_by_weight=15.0, sand_mass=1.0, linear_density_dtex=167.0),
            "content_by_weight must be at most 1, got 15",
        ),
        (lambda: bead_mass(linear_density_dtex=167.0, spacing=0.0), "spacing must be above 0 m, got 0 m"),
        (lambda: wire_content(length=-1.0, volume=1.0), "length must be at least 0 m, got -1 m"),
        (lambda: bead_count(length=1e60, spacing=1e-9), "the number of beads, length / spacing + 1, must be at most"),
        (
            lambda: axial_rigidity(linear_density_dtex=167.0, young_modulus=1e10, density=-1.0),
            "density must be above 0 kg/m^3, got -1 kg/m^3",
        ),
    ],
)
def test_a_mistake_gets_a_sentence(call, words):
    with pytest.raises(ValueError) as caught:
        call()
    assert words in str(caught.value)
    assert str(caught.value)[-1] == "."
