#!/bin/bash
# reads.sh BCC4 SCRATCH: what an installed tool opens for NetCDF and OpenVDB is found: the one is read, the other written
# and read, of those that it was built with.
set -euo pipefail
bcc4=${1:?usage: reads.sh BCC4 SCRATCH} scratch=${2:?}
readers=$("$bcc4" --version | sed 's/^absent.*//')
mkdir -p "$scratch"
if [[ $readers == *netcdf* ]]; then
  # Classic: dimensions z, y and x of 2, and a variable v of bytes.
  {
    printf 'CDF\1\0\0\0\0\0\0\0\12\0\0\0\3'
    for axis in z y x; do printf '\0\0\0\1%s\0\0\0\0\0\0\2' $axis; done
    printf '\0\0\0\0\0\0\0\0\0\0\0\13\0\0\0\1\0\0\0\1v\0\0\0\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2'
    printf '\0\0\0\0\0\0\0\0\0\0\0\1\0\0\0\10\0\0\0\160\1\2\3\4\5\6\7\10'
  } >"$scratch/v.nc"
  "$bcc4" import "$scratch/v.nc" -o "$scratch/nc.bcc4" --quiet
fi
if [[ $readers == *openvdb* ]]; then
  printf '\1\2\3\4\5\6\7\10' >"$scratch/v.raw"
  "$bcc4" import "$scratch/v.raw" --dims 2,2,2,1 --dtype u8 -o "$scratch/raw.bcc4" --quiet
  "$bcc4" export "$scratch/raw.bcc4" --all -o "$scratch/v.vdb" --quiet
  "$bcc4" import "$scratch/v.vdb" -o "$scratch/vdb.bcc4" --quiet
fi
