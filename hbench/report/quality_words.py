"""Names, findings, limits and remedies of the checks of a campaign's data, in words."""

LOAD_CELL_ZERO = (
    "the zero of the load cell was not checked: U contains its error only as far as a tolerance of "
    "full scale does"
)
NAMES = {
    "complete": "Completeness",
    "runs_accepted": "Runs accepted",
    "trials_per_point": "Trials per point",
    "repeatability": "Repeatability",
    "unlike_trials": "Unlike trials",
    "load_spread": "One load per point",
    "nominal_load": "Nominal load",
    "drift": "Drift",
    "zeros": "Zeros of the sensors",
    "zero_drift": "Drift of the zeros",
    "force_drift": "Drift of the force",
    "plausible_signs": "Plausible signs",
    "load_direction": "Direction of the load",
    "load_balance": "Balance over load",
    "load_share": "Friction over load",
    "equal_directions": "Both directions",
    "constant_force": "Constant force",
    "instruments": "Instruments",
}
FINDINGS = {  # of the checks whose words depend on their numbers alone
    "runs_accepted": "{count} of {of}, {value} %",
    "repeatability": "95 % interval of the trials is ±{value} % of friction (median)",
    "unlike_trials": "{count} of {of} trials contradict the others of their point",
    "load_spread": "at {count} of {of} points runs of different loads are averaged: no nominal "
    "load separates them, and those measured differ by up to {value} %",
    "nominal_load": "in {count} of {of} runs the load cell differs from the nominal load by more "
    "than {good:g} %, by up to {value} %",
    "zeros": "largest error {value} % of the tolerance; {count} of {of} checked sensors beyond it",
    "zero_drift": "largest change {value} % of the tolerance; {count} of {of} checked sensors "
    "beyond it",
    "force_drift": "F_T - F_applied changes by {value} % of friction over the campaign, in both "
    "directions alike",
    "load_direction": "at all {count} points the load helps the motion and supplies friction, "
    "{value} % of it (median)",
    "load_balance": "the mean friction of both directions changes by {value} % of the load",
    "load_share": "friction changes by {value} % of the load",
    "equal_directions": "at {count} of {of} speeds and loads one direction has more than twice "
    "the friction of the other",
    "constant_force": "the mean friction of both directions is the same at all speeds and loads, "
    "{value} % of friction, as by a constant force that is not measured",
}
WRONG_BALANCE = ", as it does with a wrong diameter or a wrong scale of a pressure or force"
LIMITS = {
    "complete": "good if all planned runs were completed and each point has a trial; poor below "
    "{poor:g} %",
    "runs_accepted": "good from {good:g} %, poor below {poor:g} %",
    "trials_per_point": "good from {good:g}, poor with {poor:g} or none",
    "repeatability": "good to {good:g} %, poor above {poor:g} %",
    "unlike_trials": "good if no trial differs from the others of its point by more than 15 % of "
    "friction and more than the trials scatter (95 %, for all trials at once)",
    "load_spread": "good to {good:g} % of the load or of friction, poor above {poor:g} %",
    "nominal_load": "good to {good:g} % of the nominal load",
    "drift": "good to {good:g} % or not significant; if not separated from speed, with care where "
    "more than {poor:g} % is possible, poor where a significant drift is larger; with care where "
    "its size is not known",
    "zeros": "good to {good:g} % of the sensor's tolerance at full scale; corrected in any case; "
    "poor if a zero is not known",
    "zero_drift": "good to {good:g} % of that tolerance, poor above",
    "force_drift": "good to {good:g} % or not significant; with care above, or where its size is "
    "not known",
    "plausible_signs": "good if no point contradicts this, poor if one does beyond its interval",
    "load_direction": "good if the load opposes the motion at a point, or supplies up to {good:g} "
    "% of friction",
    "load_balance": "good to {good:g} % of the load, poor above {poor:g} %, less the interval",
    "load_share": "good to {good:g} % of the load, poor above {poor:g} %, less the interval",
    "equal_directions": "good if no direction has more than twice the friction of the other",
    "constant_force": "good if the mean friction of both directions is within U or {good:g} % of "
    "friction, or differs between speeds or loads",
    "instruments": "good to {good:g} %; above, rely on differences rather than on the level",
}
STEPS = {
    "complete": "make the missing runs",
    "runs_accepted": "correct the causes of the rejected runs ([[rejected]] states what to look "
    "for), then measure again",
    "trials_per_point": "make at least three trials of each point",
    "repeatability": "make more trials of each point, or find what changes between them",
    "unlike_trials": "look at the files of the trials that the notes list: a wrong sign, scale or "
    "channel",
    "load_spread": "separate the loads: split files with several of them (hbench/store/README.md "
    "has a recipe); in the map, write {{load}} in 'files' where the names of the files have it, or "
    "make a series of each load with a label of its own; in runs.csv, fill in f_load_n. Then "
    "import again",
    "nominal_load": "compare the loads in the names of the files with those of the load cell: its "
    "unit, scale or zero may be wrong, such as a load at rest that zero: rest subtracted",
    "drift": "warm the bench up until friction no longer changes from run to run, and measure in "
    "random order",
    "possible_drift": "measure in random order, which separates drift from speed",
    "zeros": "adjust the zeros of the sensors, then check them again",
    "zero_drift": "warm the sensors up first, and check their zeros more often",
    "force_drift": "subtract the zeros at rest, or warm the sensors up first",
    "plausible_signs": "check which pressure is that of the piston side, the sign of the load "
    "cell, the instruments, their zeros and the areas of the cylinder",
    "load_direction": "if the load opposed the motion, correct the sign of the load cell (scale: "
    "-1 in a map)",
    "load_balance": "check the diameters of the cylinder, and the scale and sign of the pressures "
    "and of the load cell",
    "load_share": "check the diameters of the cylinder, and the units, scales and signs of the "
    "pressures and of the load cell",
    "equal_directions": "look for a force that is not measured, such as a weight on an upright "
    "cylinder, for a zero offset, and for a wrong diameter",
    "constant_force": "look for a force that is not measured, such as the weight of an upright "
    "piston and rod, for a zero offset, and for absolute pressures",
    "instruments": "calibrate the sensors {sensors}, and state the new tolerances in the {file}",
}
