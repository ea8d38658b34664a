"""JSON documents and their JSON Schemas, both made from one layout of the records."""
