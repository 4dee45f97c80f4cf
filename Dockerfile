# Everything that a study needs: docker build -t softsample . && docker run -v "$PWD/lab:/lab" softsample run /lab
FROM python:3.12-slim
RUN apt-get update && apt-get install -y --no-install-recommends make libegl1 libgl1-mesa-dri && rm -rf /var/lib/apt/lists/*
COPY . /softsample
WORKDIR /softsample
RUN make env VENV=/venv
ENV PATH=/venv/bin:$PATH
WORKDIR /work
ENTRYPOINT ["softsample"]
CMD ["--help"]
