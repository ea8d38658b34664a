"""The certificate's words in each language. A user's own texts are printed as they are."""

from collections.abc import Mapping

from hbench.config.conformity.certificate import Language

WORDS: Mapping[Language, Mapping[str, str]] = {
    "en": {
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
        "received": "Received",
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
        "not_traceable": "Traceability to the SI is not stated. No calibration certificate is "
        "recorded for these instruments: {instruments}.",
        "no_instruments": "The errors of the instruments are not recorded.",
        "expired": "Traceability to the SI is not given: the calibration was overdue on the day "
        "of the test for {instruments}.",
        # Method
        "procedure": "Procedure of the laboratory: {method}.",
        "method_steady": "Friction is the force of the chamber pressures on the areas of the "
        "piston less the force of the load cell, both as means while the piston moves at "
        "constant speed; it is positive against the motion. The equivalent pressure is friction "
        "divided by the area that drives the motion. The hydro-mechanical efficiency is the "
        "mechanical power delivered divided by that taken up; leakage is not part of it. Each "
        "value is the mean of the accepted trials.",
        "method_breakaway": "Breakaway is the largest friction while a slowly rising force pushes "
        "the piston after the longest rest under load.",
        "method_leakage": "Leakage is laminar and follows from the decay of the chamber pressures "
        "with all valves closed, with the bulk modulus of the bench file.",
        "method_speed_ripple": "The speed ripple is the standard deviation of the mean speeds over "
        "0.1 s, divided by the mean speed.",
        "method_drift": "The drift is the relative change of friction from the first run to the "
        "last, by least squares over the start times of the runs.",
        "software": "Evaluated with hbench {version}; firmware of the bench: {firmware}.",
        "external": "Results from external providers: {external}.",
        "no_external": "No results from external providers are recorded.",
        "no_sampling": "No sampling plan and no adjustment of the item are recorded.",
        # Results
        "series": "Series",
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
        "leak": "Leak",
        "leakage_u": "Leakage ± U (ml/min per bar)",
        "across_piston": "across the piston",
        "piston_side_out": "from the piston side outwards",
        "rod_side_out": "from the rod side outwards",
        "fewer": "Of each series the lowest and the highest speed and the one next to the working "
        "speed are stated. All other points are in results.json of the campaign.",
        "p_lr": "Back pressure: set pressure on the rod side of the load cylinder.",
        "at_back_pressure": "back pressure {pressure} bar",
        "no_load": "At a load of 0 N the cylinder moves little more than the friction of the load "
        "side: the efficiency there is not that of operation under load.",
        # Uncertainty
        "gum": "U is the expanded uncertainty according to JCGM 100 (GUM): the combined standard "
        "uncertainty of the trials and of the instruments multiplied by the stated coverage factor "
        "k, for a coverage probability of approximately 95 %. k is Student's factor for the "
        "effective degrees of freedom, or 2 where the bench file sets it. U contains no "
        "contribution from the long-term behaviour of the specimen.",
        "trials_only": "U is the half-width of the 95 % interval of the trials alone. The errors "
        "of the instruments are not known and are not part of it, so that it is no complete "
        "uncertainty according to JCGM 100.",
        "leak_interval": "The interval of the leakage is the 95 % confidence interval of its fit; "
        "no coverage factor is stated for it, and the uncertainty of the bulk modulus is not part "
        "of it.",
        # Conformity
        "overall": "Decision on the specimen: {decision} (limits of {limits}).",
        "of_product": "Product: {product}.",
        "decision_rule": "Decision rule: {rule}",
        "rule_simple": "simple acceptance (JCGM 106, 8.2): the measured value decides.",
        "rule_shared_risk": "shared risk: the measured value decides where U is at most {share} % "
        "of the limit.",
        "rule_guard_band": "guard band (JCGM 106, 8.3.2; ILAC-G8): a value passes if it is inside "
        "the limit by at least U.",
        "applies": "The statement applies to the quantities in the table. “Conforms” is the "
        "probability of conformity (JCGM 106, 7).",
        "quantity": "Quantity",
        "measured": "Measured ± U",
        "limit": "Limit",
        "conforms": "Conforms (%)",
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
        "at_pressure": "{leak} at {pressure} bar",
        "at_speed": "at {speed} mm/s",
        "after_rest": "after {dwell} s at rest",
        "at_most": "at most {high} {unit}",
        "at_least": "at least {low} {unit}",
        "between": "{low} to {high} {unit}",
        "no_limits": "No statement of conformity was asked for.",
        # Not tested
        "untested": "Not tested, because nothing was measured there: {quantities}.",
        "undecided": "Measured, but not decided, because U is too large for the decision rule or "
        "not known: {quantities}.",
        "short": "{points} of {of} operating points have fewer accepted trials than planned.",
        "rejected": "{runs} runs were rejected by screening and do not count.",
        "care": "hbench rates the data “with care”: {checks}.",
        "check_complete": "completeness",
        "check_runs_accepted": "accepted runs",
        "check_trials_per_point": "trials per point",
        "check_repeatability": "repeatability",
        "check_drift": "drift during the test",
        "check_zeros": "zeros of the sensors",
        "check_zero_drift": "drift of the zeros",
        "check_plausible_signs": "signs of friction",
        "check_instruments": "uncertainty of the instruments",
        "no_deviations": "No deviations from the schedule.",
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
    },
    "de": {
        "title": "Prüfzertifikat",
        "number": "Zertifikat Nr.",
        "page": "Seite",
        "of": "von",
        "issued": "Ausstellungsdatum",
        "replaces": "Ändert und ersetzt",
        "end": "Ende des Zertifikats",
        "not_stated": "nicht angegeben",
        "simulated_short": "SIMULIERT – KEIN ZERTIFIKAT",
        "simulated": "Simuliert. Der virtuelle Prüfstand hat diese Zahlen berechnet; kein Zylinder "
        "wurde gemessen. Das Dokument zeigt nur die Form und bescheinigt nichts.",
        "imported": "Die Läufe wurden auf einem anderen Prüfstand aufgezeichnet und importiert; "
        "das hier genannte Labor hat sie mit hbench ausgewertet.",
        "laboratory": "Labor",
        "customer": "Auftraggeber",
        "specimen": "Prüfling",
        "test": "Prüfung",
        "conditions": "Bedingungen",
        "instruments": "Messmittel und Rückführung",
        "method": "Verfahren",
        "friction": "Ergebnisse: Reibung und Wirkungsgrad bei konstanter Geschwindigkeit",
        "breakaway": "Ergebnisse: Losbrechkraft",
        "leakage": "Ergebnisse: Leckage",
        "uncertainty": "Messunsicherheit",
        "conformity": "Konformitätsaussage",
        "not_tested": "Nicht Geprüftes und Abweichungen",
        "remarks": "Bemerkungen",
        "data": "Rohdaten",
        "statements": "Gültigkeit",
        "signatures": "Freigegeben durch",
        "name": "Name",
        "address": "Anschrift",
        "contact": "Kontakt",
        "accreditation": "Akkreditierung",
        "not_accredited": "keine für diese Prüfung",
        "order": "Auftrag",
        "object": "Gegenstand",
        "cylinder": "Hydraulikzylinder",
        "serial": "Seriennummer",
        "maker": "Hersteller",
        "bore": "Kolben-Ø",
        "rod": "Stangen-Ø",
        "stroke": "Hub",
        "seals": "Dichtungen",
        "wear": "Zustand",
        "areas": "Flächen",
        "areas_mm2": "Kolbenseite {piston} mm², Stangenseite {rod} mm²",
        "received": "Eingang",
        "test_number": "Prüfnummer",
        "performed": "Datum der Prüfung",
        "place": "Ort der Prüfung",
        "operator": "Prüfer",
        "mounting": "Einbau",
        "runs": "Läufe",
        "runs_accepted": "{accepted} von {planned} nach Sichtung verwendet",
        "ambient": "Umgebung",
        "oil": "Öl",
        "oil_temperature": "Öltemperatur",
        "oil_range": "{low} bis {high} °C, Mittel {mean} °C, {place}",
        "oil_not_measured": "nicht gemessen",
        "temp_seal_k": "an der Dichtung des Zylinders",
        "temp_port_k": "an einem Anschluss des Zylinders",
        "temp_tank_k": "im Tank",
        "instrument": "Messmittel",
        "force": "Kraftaufnehmer",
        "pressure": "Druckaufnehmer",
        "the_force": "Kraftaufnehmer",
        "the_pressure": "Druckaufnehmer",
        "tolerance": "Toleranz",
        "of_reading": "{tolerance} % vom Messwert",
        "of_full_scale": "{tolerance} % von {full_scale}",
        "certificate": "Kalibrierschein",
        "calibrated": "Kalibriert",
        "due": "Fällig",
        "overdue": "{date} (überfällig)",
        "traceable": "Durch die genannten Kalibrierungen sind die Ergebnisse auf das SI "
        "zurückgeführt.",
        "not_traceable": "Die Rückführung auf das SI ist nicht angegeben; ohne verzeichneten "
        "Kalibrierschein: {instruments}.",
        "expired": "Die Rückführung auf das SI ist nicht gegeben; am Tag der Prüfung überfällig "
        "kalibriert: {instruments}.",
        "no_instruments": "Die Abweichungen der Messmittel sind nicht verzeichnet.",
        "procedure": "Verfahren des Labors: {method}.",
        "method_steady": "Die Reibung ist die Kraft der Kammerdrücke auf die Kolbenflächen "
        "abzüglich der Kraft am Kraftaufnehmer, beide als Mittel, während sich der Kolben mit "
        "konstanter Geschwindigkeit bewegt; sie ist positiv gegen die Bewegung. Der "
        "äquivalente Druck ist die Reibung geteilt durch die treibende Fläche. Der "
        "hydraulisch-mechanische Wirkungsgrad ist die abgegebene mechanische Leistung geteilt "
        "durch die aufgenommene, ohne Leckage. Jeder Wert ist das Mittel der verwendeten "
        "Wiederholungen.",
        "method_breakaway": "Die Losbrechkraft ist die größte Reibung, während nach der "
        "längsten Ruhezeit unter Last eine langsam steigende Kraft den Kolben schiebt.",
        "method_leakage": "Die Leckage ist laminar und folgt aus dem Abfall der Kammerdrücke bei "
        "geschlossenen Ventilen, mit dem Kompressionsmodul der Prüfstandsdatei.",
        "method_speed_ripple": "Die Ungleichförmigkeit ist die Standardabweichung der mittleren "
        "Geschwindigkeiten über 0,1 s, geteilt durch die mittlere Geschwindigkeit.",
        "method_drift": "Die Drift ist die relative Änderung der Reibung vom ersten bis zum "
        "letzten Lauf, nach kleinsten Quadraten über den Anfangszeiten der Läufe.",
        "software": "Ausgewertet mit hbench {version}; Firmware des Prüfstands: {firmware}.",
        "external": "Ergebnisse externer Anbieter: {external}.",
        "no_external": "Ergebnisse externer Anbieter sind nicht verzeichnet.",
        "no_sampling": "Ein Stichprobenplan und eine Justierung des Gegenstands sind nicht "
        "verzeichnet.",
        "series": "Reihe",
        "direction": "Richtung",
        "extend": "ausfahrend",
        "retract": "einfahrend",
        "load": "Last (N)",
        "back_pressure": "Gegendruck (bar)",
        "speed": "Geschw. (mm/s)",
        "friction_u": "Reibung ± U (N)",
        "pressure_u": "Äquivalenter Druck ± U (bar)",
        "efficiency_u": "Wirkungsgrad ± U (%)",
        "breakaway_u": "Losbrechkraft ± U (N)",
        "dwell": "Ruhe (s)",
        "k": "k",
        "leak": "Leckage",
        "leakage_u": "Leckage ± U (ml/min je bar)",
        "across_piston": "über den Kolben",
        "piston_side_out": "von der Kolbenseite nach außen",
        "rod_side_out": "von der Stangenseite nach außen",
        "fewer": "Angegeben sind von jeder Reihe die niedrigste und die höchste Geschwindigkeit "
        "und die der Arbeitsgeschwindigkeit nächste. Alle anderen Punkte enthält results.json der "
        "Kampagne.",
        "p_lr": "Gegendruck: eingestellter Druck auf der Stangenseite des Lastzylinders.",
        "at_back_pressure": "Gegendruck {pressure} bar",
        "no_load": "Bei 0 N Last überwindet der Zylinder kaum mehr als die Reibung der Lastseite: "
        "der Wirkungsgrad ist dort nicht der eines Betriebs unter Last.",
        "gum": "U ist die erweiterte Messunsicherheit nach JCGM 100 (GUM): die kombinierte "
        "Standardunsicherheit der Wiederholungen und der Messmittel, multipliziert mit dem "
        "angegebenen Erweiterungsfaktor k, für eine Überdeckungswahrscheinlichkeit von etwa 95 %. "
        "k ist der Studentfaktor der effektiven Freiheitsgrade, oder 2, wo die Prüfstandsdatei "
        "dies vorgibt. Ein Anteil für die Langzeitstabilität des "
        "Prüflings ist nicht enthalten.",
        "trials_only": "U ist die halbe Breite des 95-%-Intervalls der Wiederholungen allein. Die "
        "Abweichungen der Messmittel sind nicht bekannt und nicht enthalten; U ist daher keine "
        "vollständige Messunsicherheit nach JCGM 100.",
        "leak_interval": "Das Intervall der Leckage ist das 95-%-Vertrauensintervall der "
        "Anpassung; ein Erweiterungsfaktor wird dafür nicht angegeben, und die Unsicherheit des "
        "Kompressionsmoduls ist nicht enthalten.",
        "overall": "Entscheidung über den Prüfling: {decision} (Grenzwerte aus {limits}).",
        "of_product": "Produkt: {product}.",
        "decision_rule": "Entscheidungsregel: {rule}",
        "rule_simple": "einfache Annahme (JCGM 106, 8.2): Der Messwert entscheidet.",
        "rule_shared_risk": "geteiltes Risiko: Der Messwert entscheidet, wenn U höchstens "
        "{share} % des Grenzwerts beträgt.",
        "rule_guard_band": "Schutzabstand (JCGM 106, 8.3.2; ILAC-G8): Ein Wert besteht, wenn er "
        "mindestens um U innerhalb des Grenzwerts liegt.",
        "applies": "Die Aussage gilt für die Größen der Tabelle. „Konform“ ist die "
        "Wahrscheinlichkeit der Konformität (JCGM 106, 7).",
        "quantity": "Größe",
        "measured": "Messwert ± U",
        "limit": "Grenzwert",
        "conforms": "Konform (%)",
        "decision": "Entscheidung",
        "PASS": "BESTANDEN",
        "FAIL": "NICHT BESTANDEN",
        "MARGINAL": "GRENZFALL",
        "NOT TESTED": "NICHT GEPRÜFT",
        "q_friction": "Reibung",
        "q_breakaway": "Losbrechkraft",
        "q_efficiency": "Wirkungsgrad",
        "q_leakage": "Leckage",
        "q_speed_ripple": "Ungleichförmigkeit",
        "q_drift": "Drift der Reibung",
        "at_pressure": "{leak} bei {pressure} bar",
        "at_speed": "bei {speed} mm/s",
        "after_rest": "nach {dwell} s Ruhe",
        "at_most": "höchstens {high} {unit}",
        "at_least": "mindestens {low} {unit}",
        "between": "{low} bis {high} {unit}",
        "no_limits": "Eine Konformitätsaussage wurde nicht verlangt.",
        "untested": "Nicht geprüft, weil dort nicht gemessen wurde: {quantities}.",
        "undecided": "Gemessen, aber nicht entschieden, weil U für die Entscheidungsregel zu groß "
        "oder nicht bekannt ist: {quantities}.",
        "short": "{points} von {of} Betriebspunkten haben weniger verwendete Wiederholungen als "
        "geplant.",
        "rejected": "{runs} Läufe wurden bei der Sichtung verworfen und zählen nicht.",
        "care": "hbench bewertet die Daten als „mit Vorsicht zu verwenden“: {checks}.",
        "check_complete": "Vollständigkeit",
        "check_runs_accepted": "verwendete Läufe",
        "check_trials_per_point": "Wiederholungen je Punkt",
        "check_repeatability": "Wiederholbarkeit",
        "check_drift": "Drift während der Prüfung",
        "check_zeros": "Nullpunkte der Sensoren",
        "check_zero_drift": "Drift der Nullpunkte",
        "check_plausible_signs": "Vorzeichen der Reibung",
        "check_instruments": "Unsicherheit der Messmittel",
        "no_deviations": "Keine Abweichungen vom Prüfplan.",
        "record_notes": "Hinweise der Aufzeichnung (englisch): {notes}",
        "campaign": "Kampagne",
        "logs": "Messdateien",
        "logs_count": "{count} Dateien",
        "logs_sha256": "SHA-256 der Messdateien",
        "record_sha256": "SHA-256 von campaign.yaml",
        "verify": "Nachrechnen",
        "only_item": "Die Ergebnisse beziehen sich nur auf den geprüften Gegenstand, wie er "
        "eingegangen ist, und auf die angegebenen Bedingungen.",
        "in_full": "Dieses Zertifikat darf ohne Genehmigung des Labors nur vollständig "
        "vervielfältigt werden.",
        "customer_data": "Angaben zu Prüfling und Auftrag sind die des Auftraggebers oder der "
        "Prüfstandsdatei; das Labor hat sie nicht überprüft.",
        "date_signature": "Datum, Unterschrift",
    },
}
