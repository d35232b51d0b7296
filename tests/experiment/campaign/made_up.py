"""Results of campaigns that nobody has computed."""

import itertools

import numpy as np

from lmgcpy.experiment.campaign.cases import FINISHED, TO_COME, CampaignResults, CaseResult

VERSIONS = {"lmgcpy": "0.2.0", "numpy": "2.1.0"}


def case(parameters=None, numbers=None, curves=None, *, status=FINISHED, error="", seconds=2.0, versions=VERSIONS):
    """A case whose name has its parameters."""
    parameters = parameters or {}
    name = ",".join(f"{key}={value}" for key, value in parameters.items())
    return CaseResult(name, parameters, status, seconds, error, numbers or {}, curves or {}, versions)


def to_come(parameters):
    return case(parameters, status=TO_COME, seconds=0.0, versions={})


def strengths(tests=("",), seeds=5, **over):
    """A campaign of tests: all combinations of the parameters, by this many seeds."""
    cases = []
    for values in itertools.product(*over.values(), range(seeds)):
        parameters = dict(zip([*over, "seed"], values, strict=True))
        random = np.random.default_rng([len(cases), 7])
        curves = {}
        for k, test in enumerate(tests):
            strain = np.linspace(0.0, 0.3 + 0.01 * random.normal(), 60)
            size = 1e5 * (k + 1 + 0.1 * random.normal() + 0.3 * (len(cases) // seeds))
            curves[test] = {
                "strain": strain,
                "deviator [Pa]": size * (1.0 - np.exp(-strain / 0.03)),
                "change of volume [%]": 100.0 * strain * (0.1 + 0.02 * random.normal()),
            }
        numbers = {"peak deviator [Pa]": size, "friction angle [deg]": 30.0 + random.normal()}
        cases.append(case(parameters, numbers, curves))
    return CampaignResults("made up", cases)
