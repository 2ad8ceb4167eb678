"""Prints the licences of all packages that the program is built from, with their texts."""

import json
import pathlib
import subprocess

ARGUMENTS = ["cargo", "tree", "--package", "hypertexture-cli", "--edges", "normal,build", "--prefix", "none", "--locked"]
NAMES = ("licen[cs]e*", "LICEN[CS]E*", "COPYING*", "NOTICE*", "UNLICENSE*")


def main():
    lines = subprocess.run([*ARGUMENTS, "--format", "{p}"], check=True, capture_output=True, text=True).stdout
    used = {tuple(line.split()[:2]) for line in lines.splitlines() if line}
    described = subprocess.run(["cargo", "metadata", "--format-version", "1", "--locked"], check=True, capture_output=True)
    for package in json.loads(described.stdout)["packages"]:
        if package["source"] is None or (package["name"], f"v{package['version']}") not in used:
            continue
        folder = pathlib.Path(package["manifest_path"]).parent
        print(f"{'=' * 80}\n{package['name']} {package['version']}: {package['license']}\n{package['repository']}\n")
        for file in sorted({file for name in NAMES for file in folder.glob(name) if file.is_file()}):
            print(file.read_text(errors="replace"))


main()
