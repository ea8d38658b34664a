"""The certificate's words in German, by their keys."""

from hbench.records.motions import BULK_MODULUS_ERROR, TEMPERATURE_RATE_K_S

_RATE = f"{60 * TEMPERATURE_RATE_K_S:g}".replace(".", ",")

GERMAN = {
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
    "friction_alone": "Ergebnisse: Reibung bei konstanter Geschwindigkeit",
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
    "received": "Eingangsdatum",
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
    "traceable": "Durch die genannten Kalibrierungen sind die Ergebnisse auf das SI zurückgeführt.",
    "not_traceable": "Die Rückführung auf das SI ist nicht angegeben; ohne verzeichneten "
    "Kalibrierschein: {instruments}.",
    "expired": "Die Rückführung auf das SI ist nicht gegeben; am Tag der Prüfung überfällig "
    "kalibriert: {instruments}.",
    "no_instruments": "Die Abweichungen der Messmittel sind nicht verzeichnet.",
    "procedure": "Verfahren des Labors: {method}.",
    "method_steady": "Die Reibung ist die Kraft der Kammerdrücke auf die Kolbenflächen "
    "abzüglich der Kraft am Kraftaufnehmer, beide als Mittel, während sich der Kolben mit "
    "konstanter Geschwindigkeit bewegt; sie ist positiv gegen die Bewegung. Der "
    "äquivalente Druck ist die Reibung geteilt durch die treibende Fläche. Jeder Wert ist das "
    "Mittel der verwendeten Wiederholungen.",
    "method_efficiency": "Der hydraulisch-mechanische Wirkungsgrad ist die abgegebene "
    "mechanische Leistung geteilt durch die aufgenommene, ohne Leckage.",
    "method_breakaway": "Die Losbrechkraft ist die größte Reibung, während nach der "
    "längsten Ruhezeit unter Last eine langsam steigende Kraft{rate} den Kolben schiebt. Sie "
    "ist keine Reibung in Ruhe: Bis dahin kriecht der Kolben{creep}. Die Reibung baut sich erst "
    "über einen Weg auf und fällt, wenn der Kolben schneller wird; die Losbrechkraft kann daher "
    "unter der Reibung langsamer gleichförmiger Bewegung liegen.",
    "method_leakage": "Die Leckage folgt aus dem Abfall der Kammerdrücke bei geschlossenen "
    "Ventilen, mit dem angegebenen effektiven Kompressionsmodul{bulk_modulus}, "
    "einschließlich Luft im Öl und Schläuchen. {leak_law}",
    "leak_laminar": "Sie wird als laminar angenommen, also als proportional zum Druck{holds}.",
    "leak_none": "; keine Leckage war signifikant",
    "leak_holds": "; am Kolben lagen bei den {count} Halteversuchen {pressures} bar an",
    "leak_power": "Sie ist nach der Messung proportional zum Druck hoch {exponent}; angegeben sind "
    "die Werte bei {pressure} bar.",
    "method_speed_ripple": "Die Ungleichförmigkeit ist die Standardabweichung der "
    "Geschwindigkeiten zwischen den mittleren Positionen über je 0,1 s, geteilt "
    "durch die mittlere Geschwindigkeit. Sie enthält 97 % einer Schwingung von 1 Hz, "
    "41 % bei 5 Hz und nichts bei 10 Hz.",
    "method_drift": "Die Drift ist die relative Änderung der Reibung vom ersten bis zum "
    "letzten Lauf, nach kleinsten Quadraten über den Startzeiten.",
    "software": "Ausgewertet mit hbench {version}; Firmware des Prüfstands: {firmware}.",
    "external": "Ergebnisse externer Anbieter: {external}.",
    "no_external": "Ergebnisse externer Anbieter sind nicht verzeichnet.",
    "no_sampling": "Ein Stichprobenplan und eine Justierung des Gegenstands sind nicht "
    "verzeichnet.",
    "series": "Prüfung",
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
    "n": "Läufe",
    "leak": "Leckage",
    "leakage_u": "Leckage ± U (ml/min je 100 bar)",
    "across_piston": "über den Kolben",
    "piston_side_out": "von der Kolbenseite nach außen",
    "rod_side_out": "von der Stangenseite nach außen",
    "fewer": "Angegeben sind von jeder Reihe die niedrigste und die höchste Geschwindigkeit, "
    "die der Arbeitsgeschwindigkeit nächste und die der Konformitätsaussage. Alle anderen "
    "Punkte enthält results.json der Kampagne.",
    "p_lr": "Gegendruck: eingestellter Druck auf der Stangenseite des Lastzylinders.",
    "at_back_pressure": "Gegendruck {pressure} bar",
    "no_load": "Bei 0 N Last ist kein Wirkungsgrad angegeben: der Zylinder überwindet dort kaum "
    "mehr als die Reibung der Lastseite.",
    "gum": "Wo k angegeben ist, ist U die erweiterte Messunsicherheit nach JCGM 100 (GUM): die "
    "kombinierte Standardunsicherheit der Wiederholungen und der Messmittel, multipliziert mit dem "
    "Erweiterungsfaktor k, für eine Überdeckungswahrscheinlichkeit von etwa 95 %. "
    "k ist der Studentfaktor der effektiven Freiheitsgrade, oder 2, wo die Prüfstandsdatei "
    "dies vorgibt. Die Langzeitstabilität des Prüflings ist nicht enthalten.",
    "trials_only": "U ist die halbe Breite des 95-%-Intervalls der Wiederholungen allein. Die "
    "Abweichungen der Messmittel sind nicht bekannt und nicht enthalten; U ist daher keine "
    "vollständige Messunsicherheit nach JCGM 100.",
    "other_leaks": "Die übrigen Leckagen enthält die Konformitätsaussage.",
    "of_trials": "Für {quantities} enthält U nur die Streuung der Wiederholungen (95 %).",
    "each_of_runs": "je {runs} Läufe",
    "of_a_run": "{runs} Lauf",
    "load_cell_zero": "Der Nullpunkt des Kraftaufnehmers wurde nicht geprüft: U enthält seine "
    "Abweichung nur, soweit eine Toleranz vom Endwert sie enthält.",
    "load_cell_zero_of_reading": "U enthält keine Nullpunktabweichung des Kraftaufnehmers: seine "
    "Toleranz gilt vom Messwert, und sein Nullpunkt wurde nicht geprüft. Eine Abweichung von "
    "0,1 % seines Endwerts ({full_scale}) würde die Reibung um {change} ändern.",
    "leak_interval": "U der Leckage ist die Wurzel der Quadratsumme dreier Anteile: des "
    "95-%-Intervalls der Anpassung an alle Halteversuche, mindestens aber der Leckage, die einen "
    "Druck während des Haltens um die kleinste Stufe seiner aufgezeichneten Werte{step} ändert; "
    f"einer angenommenen Änderung der Öltemperatur um {_RATE} K/min, oder der größten in einem "
    "Halteversuch gemessenen, falls sie größer ist; eines "
    f"angenommenen Fehlers des effektiven Kompressionsmoduls von {100 * BULK_MODULUS_ERROR:.0f} %. "
    "U hat keinen Faktor k, weil die angenommenen Anteile Fehlergrenzen sind. Nicht enthalten: "
    "Fehler der Totvolumina, Drift der Druckaufnehmer, Leckage der geschlossenen Ventile.",
    "of_limits": "Grenzwerte: {limits}.",
    "of_product": "Produkt: {product}.",
    "decision_rule": "Entscheidungsregel: {rule}",
    "rule_simple": "einfache Annahme (JCGM 106, 8.2): Der Messwert entscheidet.",
    "rule_shared_risk": "geteiltes Risiko: Der Messwert entscheidet, wenn U höchstens "
    "{share} % des Grenzwerts beträgt.",
    "rule_guard_band": "Schutzabstand (JCGM 106, 8.3.2; ILAC-G8): BESTANDEN, wenn der Wert "
    "mindestens um U innerhalb des Grenzwerts liegt, GRENZFALL, wenn um weniger, NICHT BESTANDEN "
    "jenseits des Grenzwerts.",
    "applies": "Die Aussage gilt für die Größen der Tabelle. „Konform“ ist die "
    "Wahrscheinlichkeit der Konformität (JCGM 106, 7), für eine Studentverteilung mit dem "
    "95-%-Intervall Messwert ± U; wo U keinen Faktor k hat, ist diese Verteilung angenommen.",
    "not_calibrated": "U beruht auf Toleranzen; ohne verzeichneten Kalibrierschein: {instruments}.",
    "worst_speed": "Wo ein Grenzwert keine Geschwindigkeit nennt, wird jede Reihe bei der "
    "Geschwindigkeit mit der kleinsten Wahrscheinlichkeit der Konformität entschieden.",
    "names": "Namen von Prüfungen und Grenzwerten sind die des Labors.",
    "quantity": "Größe",
    "measured": "Messwert ± U",
    "limit": "Grenzwert",
    "conforms": "Konform",
    "decision": "Entscheidung",
    "PASS": "BESTANDEN",
    "FAIL": "NICHT BESTANDEN",
    "MARGINAL": "GRENZFALL",
    "NOT TESTED": "NICHT GEPRÜFT",
    "q_friction": "Reibung",
    "q_breakaway": "Losbrechen",
    "q_efficiency": "Wirkungsgrad",
    "q_leakage": "Leckage",
    "q_speed_ripple": "Ungleichförmigkeit",
    "q_drift": "Drift der Reibung",
    "of_load": "Last {load} N",
    "at_pressure": "{leak} bei {pressure} bar",
    "at_speed": "bei {speed} mm/s",
    "after_rest": "nach {dwell} s Ruhe",
    "at_most": "max. {high} {unit}",
    "at_least": "min. {low} {unit}",
    "between": "{low} bis {high} {unit}",
    "no_limits": "Eine Konformitätsaussage wurde nicht verlangt.",
    "tested": "Geprüfte Grenzwerte: {tested} von {count} (Entscheidungen: {decisions}, eine für "
    "jede Reihe).",
    "untested": "Für die übrigen nicht gemessen: {quantities}.",
    "no_runs": "Die Kampagne enthält keine Läufe für: {quantities}.",
    "not_determined": "Durch die Läufe dafür nicht bestimmt: {quantities}.",
    "impossible": "Gemessen, aber nicht entschieden, weil der Wert um mehr als U unmöglich ist; "
    "ein Vorzeichen, ein Nullpunkt, eine Fläche oder die Drift eines Messmittels oder der "
    "Öltemperatur verfälscht ihn: {quantities}.",
    "u_large": "Gemessen, aber nicht entschieden, weil U für die Entscheidungsregel zu groß ist: "
    "{quantities}.",
    "u_unknown": "Gemessen, aber nicht entschieden, weil U nicht bekannt ist: {quantities}.",
    "cause_quantity": "kein verwendeter Lauf bestimmt den Wert",
    "cause_speed": "nicht bei dieser Geschwindigkeit",
    "cause_load": "nicht bei dieser Last",
    "cause_back_pressure": "nicht bei diesem Gegendruck",
    "cause_rest": "nicht nach dieser Ruhezeit",
    "cause_combination": "nicht mit allen Angaben des Grenzwerts",
    "cause_series": "nur in anderen Reihen",
    "cause_pressure": "der höchste mittlere Druck eines Halteversuchs ist {pressure} bar",
    "cause_times": "die Zeiten der Läufe sind nicht bekannt",
    "cause_area": "die treibende Fläche ist nicht bekannt",
    "cause_undriven": "kein Öl treibt eine der Richtungen",
    "cause_rejected": "an einem der Punkte wurde kein Lauf verwendet",
    "short": "{points} von {of} Betriebspunkten haben weniger verwendete Wiederholungen als "
    "geplant.",
    "rejected": "{runs} Läufe wurden bei der Sichtung verworfen und zählen nicht.",
    "care": "Die Daten sind „mit Vorsicht zu verwenden“ (Stufen: gut, mit Vorsicht, schlecht); "
    "Grund: {checks}.",
    "check_complete": "Vollständigkeit",
    "check_runs_accepted": "verwendete Läufe",
    "check_trials_per_point": "Wiederholungen je Punkt",
    "check_repeatability": "Wiederholbarkeit",
    "check_load_spread": "eine Last je Messpunkt",
    "check_unlike_trials": "Versuche im Widerspruch zu den anderen ihres Punkts",
    "check_nominal_load": "Nennlast",
    "check_drift": "Drift während der Prüfung",
    "check_zeros": "Nullpunkte der Sensoren",
    "check_zero_drift": "Drift der Nullpunkte",
    "check_force_drift": "Drift der Kraft, in beiden Richtungen gleich",
    "check_plausible_signs": "Vorzeichen der Reibung",
    "check_load_direction": "Richtung der Last",
    "check_load_balance": "Kräftebilanz über der Last",
    "check_load_share": "Änderung der Reibung mit der Last",
    "check_equal_directions": "Unterschied der Richtungen",
    "check_constant_force": "gleichbleibende Kraft in beiden Richtungen",
    "check_instruments": "Unsicherheit der Messmittel",
    "no_deviations": "Keine Abweichungen vom Prüfplan.",
    "no_schedule": "Ein Prüfplan ist nicht angegeben; alle importierten Läufe zählen.",
    "run_remarks": "Bemerkungen zu verwendeten Läufen (englisch): {remarks}.",
    "and": "und",
    "record_notes": "Hinweise der Aufzeichnung (englisch): {notes}",
    "campaign": "Kampagne",
    "logs": "Messdateien",
    "logs_count": "{count} Dateien",
    "logs_sha256": "SHA-256 der Messdateien",
    "record_sha256": "SHA-256 campaign.yaml",
    "verify": "Nachrechnen",
    "only_item": "Die Ergebnisse beziehen sich nur auf den geprüften Gegenstand, wie er "
    "eingegangen ist, und auf die angegebenen Bedingungen.",
    "in_full": "Dieses Zertifikat darf ohne Genehmigung des Labors nur vollständig "
    "vervielfältigt werden.",
    "customer_data": "Angaben zu Prüfling und Auftrag sind die des Auftraggebers oder der "
    "Prüfstandsdatei; das Labor hat sie nicht überprüft.",
    "date_signature": "Datum, Unterschrift",
}
