"""The columns of a log in a document of `sagnac allan --json`."""


def columns(document):
    """For each column its row of `records`, with the rows of the other tables by their names; `coefficients` are those of the fit."""
    tables = document["tables"]

    def own(table, name):
        return [row for row in tables[table] if row["column"] == name]

    found = []
    for record in tables["records"]:
        rows = {table: own(table, record["column"]) for table in tables if table not in ("records", "limits")}
        rows["coefficients"] = [row for row in rows["coefficients"] if row["intervals"] != "of the curve"]
        found.append({**record, **rows})
    return found
