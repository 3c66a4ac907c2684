#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints the software bill of a build as an SPDX 2.3 file: software_bill.py VERSION [ARCHITECTURE].

Packages and licences come from the table in SECURITY.md, versions from this computer. A package that is not installed
here has no version, and is left out if only a build needs it. ARCHITECTURE, such as arm64, is the processor of the build,
where packages are installed for two. SOURCE_DATE_EPOCH, where it is set, gives the date.
"""

import datetime
import json
import os
import re
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
OWN_LICENCE = "GPL-2.0-or-later"


def table():
    """Rows of the table: package, licence as an SPDX expression, purpose."""
    with open(os.path.join(ROOT, "SECURITY.md"), encoding="utf-8") as file:
        rows = re.findall(r"^\| ([a-z][a-z0-9.+-]+) \| ([^|]+) \| ([^|]+) \|", file.read(), re.M)
    return [(package, licence.replace(" and ", " AND ").replace(" with ", " WITH "), use) for package, licence, use in rows]


def installed_version(package, architecture):
    """Of a package, or of the one that provides it under this name; empty where it is not installed."""
    words = ["dpkg-query", "--show", "--showformat=${db:Status-Status} ${Architecture} ${Version}\n", package]
    shown = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False).stdout
    installed = dict(re.findall(r"^installed (\S+) (\S+)$", shown, re.M))
    return installed.get(architecture) or next(iter(installed.values()), "")


def entry(package, version, licence):
    return {
        "SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", package),
        "name": package,
        **({"versionInfo": version} if version else {}),
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": licence,
        "licenseDeclared": licence,
        "copyrightText": "NOASSERTION",
    }


def bill(version, architecture=""):
    own = entry("plumb", version, OWN_LICENCE)
    used = []
    for package, licence, use in table():
        found = installed_version(package, architecture)
        if found or not use.startswith("the build"):
            used.append(entry(package, found, licence))
    moment = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"plumb-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/plumb-{version}-{moment}",
        "creationInfo": {
            "created": datetime.datetime.fromtimestamp(moment, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: plumb-software_bill"],
        },
        "packages": [own, *used],
        "relationships": [
            {"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": own["SPDXID"]},
            *(
                {"spdxElementId": own["SPDXID"], "relationshipType": "DEPENDS_ON", "relatedSpdxElement": each["SPDXID"]}
                for each in used
            ),
        ],
    }


if __name__ == "__main__":
    json.dump(bill(*sys.argv[1:]), sys.stdout, indent=2)
    print()
