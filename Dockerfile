# The commands of the README in a container:
#
#     docker build -t ase-roughcontact .            # install, and the first run
#     docker run --rm -v "$PWD:/work" ase-roughcontact run my.toml
#     docker build --target test .                  # the test command

FROM python:3.13-slim AS source
WORKDIR /source
COPY . .

FROM source AS test
RUN .ci/run

FROM source
RUN python3 -m venv .venv && .venv/bin/pip install '.[fast]' && .venv/bin/ase-roughcontact run \
    && rm -r roughcontact-out
ENV PATH=/source/.venv/bin:$PATH
WORKDIR /work
ENTRYPOINT ["ase-roughcontact"]
