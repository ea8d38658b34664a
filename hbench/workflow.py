"""The flow, one function an arrow: schedule -> campaign -> results -> report."""

import hashlib
import platform
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from hbench.analysis.average import curves
from hbench.analysis.calibrate import calibrate
from hbench.analysis.efficiency import efficiency
from hbench.analysis.fit import fits
from hbench.analysis.screen import screen
from hbench.config.bench import Bench, parse_bench, parse_plant
from hbench.config.importmap import parse_import_map
from hbench.config.loading import read_yaml
from hbench.config.schedule import Schedule, parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.plan import estimate_seconds, plan_runs
from hbench.experiment.runner import Progress, run_campaign
from hbench.protocol.dictionary import FLAGS, PROTOCOL, RECORD, dictionary_hash
from hbench.records import Results, RunPlan
from hbench.store.campaign import CampaignWriter, load_campaign, write_results
from hbench.store.foreign import ImportSummary, import_folder
