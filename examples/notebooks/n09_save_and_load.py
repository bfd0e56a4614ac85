"""
Save, load, compare
===================

A case is saved as the file that the command line runs, a result as NetCDF. What is loaded equals what was saved; two of a kind are
compared.
"""

import tempfile

import valvetrain as vt

case = vt.Case("job-t").set({"operation.cycles": 3})
run = case.run("2000 rpm", models="massless")
with tempfile.TemporaryDirectory() as folder:
    case_file = vt.save(case, f"{folder}/mine.toml")
    run_file = vt.save(run, f"{folder}/run.nc")
    print(vt.load(case_file) == case, vt.load(run_file).identical(run))
print(vt.diff(vt.Case("job-t"), case))

# %%
# A case shows what it says, and its file.

case
