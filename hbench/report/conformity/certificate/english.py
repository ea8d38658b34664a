"""The certificate's words in English, by their keys."""

from hbench.report.campaign.motion_rows import LEAKS
from hbench.report.conformity.text import NOT_IN_U_OF_LEAKAGE, U_OF_LEAKAGE
from hbench.report.quality_words import LOAD_CELL_ZERO

ENGLISH = {
    "title": "Test certificate",
    "number": "Certificate no.",
    "page": "page",
    "of": "of",
    "issued": "Date of issue",
    "replaces": "Amends and replaces",
    "end": "End of certificate",
    "not_stated": "not stated",
    # Marks
    "simulated_short": "SIMULATED – NOT A CERTIFICATE",
    "simulated": "Simulated. The virtual rig computed these numbers; no cylinder was measured. "
    "This document shows the form only and certifies nothing.",
    "imported": "The runs were logged on another bench and imported; the laboratory named "
    "here evaluated them with hbench.",
    # Parts
    "laboratory": "Laboratory",
    "customer": "Customer",
    "specimen": "Specimen",
    "test": "Test",
    "conditions": "Conditions",
    "instruments": "Instruments and traceability",
    "method": "Method",
    "friction": "Results: friction and efficiency at constant speed",
    "friction_alone": "Results: friction at constant speed",
    "breakaway": "Results: breakaway",
    "leakage": "Results: leakage",
    "uncertainty": "Uncertainty of measurement",
    "conformity": "Statement of conformity",
    "not_tested": "Not tested and deviations",
    "remarks": "Remarks",
    "data": "Raw data",
    "statements": "Validity",
    "signatures": "Authorised by",
    # Facts
    "name": "Name",
    "address": "Address",
    "contact": "Contact",
    "accreditation": "Accreditation",
    "not_accredited": "none for this test",
    "order": "Order",
    "object": "Object",
    "cylinder": "hydraulic cylinder",
    "serial": "Serial number",
    "maker": "Maker",
    "bore": "Bore",
    "rod": "Rod",
    "stroke": "Stroke",
    "seals": "Seals",
    "wear": "Condition",
    "areas": "Areas",
    "areas_mm2": "piston side {piston} mm², rod side {rod} mm²",
    "received": "Date of receipt",
    "test_number": "Test number",
    "performed": "Date of the test",
    "place": "Place of the test",
    "operator": "Operator",
    "mounting": "Mounting",
    "runs": "Runs",
    "runs_accepted": "{accepted} of {planned} accepted by screening",
    "ambient": "Ambient",
    "oil": "Oil",
    "oil_temperature": "Oil temperature",
    "oil_range": "{low} to {high} °C, mean {mean} °C, {place}",
    "oil_not_measured": "not measured",
    "temp_seal_k": "at the seal of the cylinder",
    "temp_port_k": "at a port of the cylinder",
    "temp_tank_k": "in the tank",
    # Instruments
    "instrument": "Instrument",
    "force": "Load cell",
    "pressure": "Pressure transducers",
    "the_force": "the load cell",
    "the_pressure": "the pressure transducers",
    "tolerance": "Tolerance",
    "of_reading": "{tolerance} % of reading",
    "of_full_scale": "{tolerance} % of {full_scale}",
    "certificate": "Certificate",
    "calibrated": "Calibrated",
    "due": "Due",
    "overdue": "{date} (overdue)",
    "traceable": "The calibrations above make the results traceable to the SI.",
    "not_traceable": "Traceability to the SI is not stated: no calibration certificate is "
    "recorded for {instruments}.",
    "no_instruments": "The errors of the instruments are not recorded.",
    "expired": "Traceability to the SI is not given: the calibration was overdue on the day "
    "of the test for {instruments}.",
    # Method
    "procedure": "Procedure of the laboratory: {method}.",
    "method_steady": "Friction is the force of the chamber pressures on the areas of the "
    "piston less the force of the load cell, both as means while the piston moves at "
    "constant speed; it is positive against the motion. The equivalent pressure is friction "
    "divided by the area that drives the motion. Each value is the mean of the accepted trials.",
    "method_efficiency": "The hydro-mechanical efficiency is the mechanical power delivered "
    "divided by that taken up; leakage is not part of it.",
    "method_breakaway": "Breakaway is the largest friction while a slowly rising force{rate} "
    "pushes the piston after the longest rest under load. It is not a friction at rest: the piston "
    "creeps up to then{creep}. Friction takes some travel to build up, and falls as the piston "
    "becomes faster; breakaway can therefore be below the friction of slow steady motion.",
    "method_leakage": "Leakage follows from the decay of the chamber pressures with all valves "
    "closed, with the stated effective bulk modulus{bulk_modulus}, air in the oil and "
    "hoses included. {leak_law}",
    "leak_laminar": "It is assumed to be laminar, thus proportional to the pressure{holds}.",
    "leak_none": "; no leak was significant",
    "leak_holds": "; across the piston, the {count} holds had {pressures} bar",
    "leak_power": "It was found to be proportional to the pressure to the power {exponent}; the "
    "values stated are those at {pressure} bar.",
    "method_speed_ripple": "The speed ripple is the standard deviation of the speeds between the "
    "mean positions of successive intervals of 0.1 s, divided by the mean speed. It contains "
    "97 % of a ripple of 1 Hz, 41 % of one of 5 Hz and none of one of 10 Hz.",
    "method_drift": "The drift is the relative change of friction from the first run to the "
    "last, by least squares over the start times of the runs.",
    "software": "Evaluated with hbench {version}; firmware of the bench: {firmware}.",
    "external": "Results from external providers: {external}.",
    "no_external": "No results from external providers are recorded.",
    "no_sampling": "No sampling plan and no adjustment of the item are recorded.",
    # Results
    "series": "Test",
    "direction": "Direction",
    "extend": "extending",
    "retract": "retracting",
    "load": "Load (N)",
    "back_pressure": "Back pressure (bar)",
    "speed": "Speed (mm/s)",
    "friction_u": "Friction ± U (N)",
    "pressure_u": "Equivalent pressure ± U (bar)",
    "efficiency_u": "Efficiency ± U (%)",
    "breakaway_u": "Breakaway ± U (N)",
    "dwell": "Rest (s)",
    "k": "k",
    "n": "Runs",
    "leak": "Leak",
    "leakage_u": "Leakage ± U (ml/min per 100 bar)",
    **LEAKS,
    "fewer": "Of each series the lowest and the highest speed, the one next to the working "
    "speed and those of the statement of conformity are stated. All other points are in "
    "results.json of the campaign.",
    "p_lr": "Back pressure: set pressure on the rod side of the load cylinder.",
    "at_back_pressure": "back pressure {pressure} bar",
    "no_load": "No efficiency is stated at a load of 0 N: the cylinder delivers little more than "
    "the friction of the load side there.",
    # Uncertainty
    "gum": "Where k is stated, U is the expanded uncertainty according to JCGM 100 (GUM): the "
    "combined standard uncertainty of the trials and of the instruments multiplied by the coverage "
    "factor k, for a coverage probability of approximately 95 %. k is Student's factor for the "
    "effective degrees of freedom, or 2 where the bench file sets it. U contains no "
    "contribution from the long-term behaviour of the specimen.",
    "trials_only": "U is the half-width of the 95 % interval of the trials alone. The errors "
    "of the instruments are not known and are not part of it, so that it is no complete "
    "uncertainty according to JCGM 100.",
    "other_leaks": "The statement of conformity has the other leakages.",
    "of_trials": "U of {quantities} is that of the trials alone (95 %).",
    "each_of_runs": "{runs} runs each",
    "of_a_run": "{runs} run",
    "leak_interval": f"U of leakage is {U_OF_LEAKAGE}. It has no factor k, since the assumed parts "
    f"are limits of error. {NOT_IN_U_OF_LEAKAGE}.",
    "load_cell_zero": f"{LOAD_CELL_ZERO[:1].upper()}{LOAD_CELL_ZERO[1:]}.",
    "load_cell_zero_of_reading": "U contains no zero error of the load cell: its tolerance is "
    "relative to the reading, and its zero was not checked. A zero error of 0.1 % of its full "
    "scale ({full_scale}) would change friction by {change}.",
    # Conformity
    "of_limits": "Limits: {limits}.",
    "of_product": "Product: {product}.",
    "decision_rule": "Decision rule: {rule}",
    "rule_simple": "simple acceptance (JCGM 106, 8.2): the measured value decides.",
    "rule_shared_risk": "shared risk: the measured value decides where U is at most {share} % "
    "of the limit.",
    "rule_guard_band": "guard band (JCGM 106, 8.3.2; ILAC-G8): PASS inside the limit by at least "
    "U, MARGINAL inside by less, FAIL beyond the limit.",
    "applies": "The statement applies to the quantities in the table. “Conforms” is the "
    "probability of conformity (JCGM 106, 7), for a Student distribution with the 95 % interval of "
    "measured value ± U; where U has no factor k, this distribution is an assumption.",
    "not_calibrated": "U rests on stated tolerances: no calibration certificate is recorded for "
    "{instruments}.",
    "worst_speed": "Where a limit states no speed, each series is decided at the speed with "
    "the lowest probability of conformity.",
    "names": "Names of tests and limits are the laboratory's.",
    "quantity": "Quantity",
    "measured": "Measured ± U",
    "limit": "Limit",
    "conforms": "Conforms",
    "decision": "Decision",
    "PASS": "PASS",
    "FAIL": "FAIL",
    "MARGINAL": "MARGINAL",
    "NOT TESTED": "NOT TESTED",
    "q_friction": "friction",
    "q_breakaway": "breakaway",
    "q_efficiency": "efficiency",
    "q_leakage": "leakage",
    "q_speed_ripple": "speed ripple",
    "q_drift": "drift of friction",
    "of_load": "load {load} N",
    "at_pressure": "{leak} at {pressure} bar",
    "at_speed": "at {speed} mm/s",
    "after_rest": "after {dwell} s at rest",
    "at_most": "at most {high} {unit}",
    "at_least": "at least {low} {unit}",
    "between": "{low} to {high} {unit}",
    "no_limits": "No statement of conformity was asked for.",
    # Not tested
    "tested": "Limits tested: {tested} of {count} (decisions: {decisions}, one for each series).",
    "untested": "Not measured for the others: {quantities}.",
    "no_runs": "The campaign has no runs that measure: {quantities}.",
    "not_determined": "Not determined by the runs made for it: {quantities}.",
    "impossible": "Measured, but not decided, because the value is impossible by more than its U; "
    "a sign, a zero, an area or the drift of an instrument or of the oil temperature falsifies "
    "it: {quantities}.",
    "u_large": "Measured, but not decided, because U is too large for the decision rule: "
    "{quantities}.",
    "u_unknown": "Measured, but not decided, because U is not known: {quantities}.",
    "cause_quantity": "no accepted runs determine it",
    "cause_speed": "not at this speed",
    "cause_load": "not at this load",
    "cause_back_pressure": "not at this back pressure",
    "cause_rest": "not after this rest",
    "cause_combination": "not with all that the limit states",
    "cause_series": "only in other series",
    "cause_pressure": "the highest mean pressure of a hold is {pressure} bar",
    "cause_times": "the times of the runs are not known",
    "cause_area": "the driving area is not known",
    "cause_undriven": "no oil drives one of the directions",
    "cause_rejected": "no run was accepted at one of the points",
    "short": "{points} of {of} operating points have fewer accepted trials than planned.",
    "rejected": "{runs} runs were rejected by screening and do not count.",
    "care": "The data is rated “with care” (grades: good, with care, poor); reason: {checks}.",
    "check_complete": "completeness",
    "check_runs_accepted": "accepted runs",
    "check_trials_per_point": "trials per point",
    "check_repeatability": "repeatability",
    "check_load_spread": "one load per point",
    "check_unlike_trials": "trials that contradict the others of their point",
    "check_nominal_load": "nominal load",
    "check_drift": "drift during the test",
    "check_zeros": "zeros of the sensors",
    "check_zero_drift": "drift of the zeros",
    "check_force_drift": "drift of the force in both directions alike",
    "check_plausible_signs": "signs of friction",
    "check_load_direction": "direction of the load",
    "check_load_balance": "balance of forces over the load",
    "check_load_share": "change of friction with the load",
    "check_equal_directions": "difference of the directions",
    "check_constant_force": "constant force in both directions",
    "check_instruments": "uncertainty of the instruments",
    "no_deviations": "No deviations from the schedule.",
    "no_schedule": "No schedule is recorded; all imported runs count.",
    "run_remarks": "Remarks on accepted runs: {remarks}.",
    "and": "and",
    "record_notes": "Notes of the record: {notes}",
    # Data
    "campaign": "Campaign",
    "logs": "Logs",
    "logs_count": "{count} files",
    "logs_sha256": "SHA-256 of the logs",
    "record_sha256": "SHA-256 of campaign.yaml",
    "verify": "Verify",
    # Validity
    "only_item": "The results relate only to the item tested, as it was received, and to the "
    "conditions stated.",
    "in_full": "This certificate shall not be reproduced except in full without the approval "
    "of the laboratory.",
    "customer_data": "Data of the specimen and of the order are as stated by the customer "
    "or recorded in the bench file; the laboratory has not verified them.",
    "date_signature": "Date, signature",
}
